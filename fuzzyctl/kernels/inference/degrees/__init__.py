"""Membership degrees as programs."""
