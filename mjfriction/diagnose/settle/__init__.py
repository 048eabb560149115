"""What becomes of the stated values that were refitted: held as stated, or findings of their own."""
