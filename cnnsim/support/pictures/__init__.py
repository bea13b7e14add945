"""Pictures of every kind: read and written as CNN values, one or one after the other, films of them."""
