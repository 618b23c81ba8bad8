"""The conversation of a recording once more: the same words, the same answers, the same turns?"""
