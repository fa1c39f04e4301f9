"""Our own methods put to participants whose truth is known: are they as they say?"""
