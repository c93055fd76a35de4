"""Work beside Blender, and its caches.

Here belong the one worker thread, the timer that looks after tasks without a click, and the caches of prepared plans
and solved shells. Nothing here knows what a task does.
"""
