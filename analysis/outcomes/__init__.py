"""What participants say together of one dependent value: values, no sentences."""
