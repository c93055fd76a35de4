"""The sidebar and the menus."""
