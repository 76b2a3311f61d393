"""Poses, lenses, cameras and the transform tree."""
