"""The sidebar and the menus.

Each panel is a class on `tab.Tab`. A panel reads the active object, the settings in `properties` and the stored report;
it calls operators and changes nothing itself. It draws in every state of the scene without raising.
"""
