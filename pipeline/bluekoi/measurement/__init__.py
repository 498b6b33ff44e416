"""Candidate measurement errors: one file each, the folder is the list. Each adds to the stages of
`observation`.
"""
