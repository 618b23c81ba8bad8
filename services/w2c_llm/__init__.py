"""Constrained completion for anyone who asks: chat and JSON schema, or chat and options, to an answer.

`node.py` is bus in, bus out; `engine.py` owns the model's thread; `answering.py` checks what models say;
`llama_cpp_backend.py` and `openai_backend.py` are the models. Nothing here knows of robots or contacts.
"""
