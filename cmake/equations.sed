# A filter for Doxygen. In the comments an equation stands by itself, three blanks behind the slashes: it is shown as
# it stands, as Markdown shows what is indented by more.
/^ *\/\/\/$/!b
:blank
n
/^ *\/\/\/$/b blank
/^ *\/\/\/   [^ -]/!b
:equation
s/\/\/\/   /\/\/\/       /
n
/^ *\/\/\/   /b equation
/^ *\/\/\/$/b blank
