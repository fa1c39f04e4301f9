"""What is kept on the disk: journal and data set, durably."""
