"""The trials table: a row, its columns, what a cell may hold; shared by recording and analysing."""
