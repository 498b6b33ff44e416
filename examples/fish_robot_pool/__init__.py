"""A modular fish robot in a long tank: slower at the tank's edge, or only badly tracked there?"""
