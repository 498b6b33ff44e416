"""One self-contained page with all of a study, and the overlay videos that go with it.

write_report(campaign, figures, figures_dir, overlays_dir, path)   the page
overlay.trial_overlay(campaign, trial_id, results, path)           one trial's video
"""

from .page import write_report

__all__ = ["write_report"]
