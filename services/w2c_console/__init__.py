"""The operator's web page: camera, target, chat, confirm, stop, and the state of every process."""
