"""The truth of a synthetic study beside the results obtained without it.

seal -> content -> comparison -> page
"""
