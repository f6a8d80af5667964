# Links among the pages of docs/ mean nothing to Doxygen: their text stays.
s/\[([^][]*)\]\([^()]*\)/\1/g
