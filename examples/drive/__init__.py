"""A linear drive: what holds it back beside mass and viscous friction."""
