"""A study made ready to run: pre-filled from its files, checked, previewed, set up in the browser.

prefill        rows of trials.csv and a study.yaml from the files of a folder
input_check    all that is wrong with a study's files, for `bluekoi check` and the page
draft          study.yaml and trials.csv as text to edit
draft_saving   both files saved or neither, with a copy of what is replaced
preview        the detection on a few frames of a trial
server         the page of `bluekoi setup`, on the local machine only
"""
