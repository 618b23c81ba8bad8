"""Constrained completion for anyone: a chat and a JSON schema, or options, to a checked answer.

`node.py` is bus in, bus out; `engine.py` owns the model's thread; `answering.py` checks what models
say; `llama_cpp_backend.py`, `openai_backend.py` and `replay_backend.py` are the models. Nothing
here knows of robots.
"""
