"""Parts that several foreign formats share."""
