"""The objects a shell consists of, their colours and their measures."""
