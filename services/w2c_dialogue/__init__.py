"""From words to a confirmed contact: conversation, prompts, and the modules of the paper."""
