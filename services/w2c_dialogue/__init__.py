"""From words to a confirmed contact: the conversation, the prompts, and the modules of the paper."""
