"""One self-contained page with all of a study, and the overlay videos that go with it.

page.write_report(campaign, figures, figures_dir, overlays_dir, path)   the page
overlay.trial_overlay(campaign, trial_id, results, path)                one trial's video

Nothing is imported here: the overlays do not depend on the page's code, and are not drawn anew
when it is edited.
"""
