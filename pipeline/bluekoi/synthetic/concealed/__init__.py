"""Studies whose truth is drawn and concealed; shares no code with the analysis.

effects, faults -> recipe (what is drawn) -> campaign (its trials) -> strength -> writing
"""
