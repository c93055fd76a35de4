"""CMC Form-Finding as a Blender extension: the entry that Blender calls.

Inside Blender this folder is the package ``bl_ext.<repository>.cmc_formfinding``. Everything is
imported on registration, so that the file can also be read where there is no ``bpy``.
"""


def register() -> None:
    """Enable the extension."""
    from . import cmc_addon

    cmc_addon.register()


def unregister() -> None:
    """Disable it again."""
    from . import cmc_addon

    cmc_addon.unregister()
