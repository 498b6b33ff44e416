"""A long tank with a rigid body in Kirchhoff's equations and blade elements along its axis.

The head carries the plate of the published model. All other forces of the body are sums over
blade elements from the hinge to the tip of the tail, all inertia of the water is a matrix of
added masses, and time runs by Runge and Kutta's fourth-order rule. With nothing hidden, what
remains is the two-plate model and no other force.
"""

from .studies import generate

__all__ = ["generate"]
