"""Concealed studies: made from a seed, analysed in a process that cannot read the truth, scored.

plan (which studies) -> make -> guard, find (each study's folder alone) -> score -> table
rivals: what others would have used on the same studies
"""
