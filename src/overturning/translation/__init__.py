"""Languages: tables of words of each language, and the translation of the program's English texts by them."""
