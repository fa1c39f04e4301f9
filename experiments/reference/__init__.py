"""The keys of every file that users write, from the classes that read them: at the prompt and as pages of the docs."""
