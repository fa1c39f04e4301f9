"""What an argument must be, and the sentence that refuses it: one vocabulary, each word in one place.

- `config.strict` reads what people write into files: unknown keys, missing keys, the `kind` of a table, types, units.
  Then it builds the class, which checks itself as below, so that a value is refused alike in a file and in a call.
- `checked` (a decorator) reads what annotations and names of arguments say already: the kind, finiteness, the domain of
  the unit. It belongs on what others call with arrays and numbers: the functions and classes of `stimuli`.
- `require` has a word for what a type cannot say: `positive`, `within`, `below_1` (0 to below 1: a rate), `not_zero`,
  `whole`, `one_of`, `lookup`, `some`, `ascending`, ... A class that is not `checked` says all of it so.
- `require.expect` is the word for a rule of one place (an interval of its own, `low < high`): whether it holds, and the
  three parts of the sentence. What two places ask for alike becomes a word of its own.
- A `raise` is written by hand only where its sentence has another form: one that says more than what was found and what
  was expected on a line, or that is told as it is computed.
"""
