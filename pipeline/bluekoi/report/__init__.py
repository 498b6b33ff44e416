"""A self-contained page with all results of a study, and the overlay videos of its trials.

page.write_report(campaign, figures, figures_dir, overlays_dir, path)   the page
overlay.write_trial_overlay(campaign, trial_id, results, path)          one trial's video

Nothing is imported here, so that editing the page's code does not invalidate the overlays.
"""
