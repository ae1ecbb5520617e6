"""Membership degrees as programs, by table or by branches."""
