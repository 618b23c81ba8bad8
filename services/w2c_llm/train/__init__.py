"""Trains the embedded language model from a corpus of chats, and exports it as GGUF.

Needs the extra `train`; nothing here runs in the service.
"""
