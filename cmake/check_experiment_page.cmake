# cmake -DREADERS=src/experiment -DDOCS=docs -P check_experiment_page.cmake
#
# Every key that the readers of experiment files in that folder look up by name stands in a list or a table of
# experiment.md or experiment_more.md, or as a section in a heading. Those that they take from the fields of a
# record are checked by tests/report/page_tables_test.cpp.

cmake_minimum_required(VERSION 3.25)

set(code "")
file(GLOB readers ${READERS}/read_*.cpp)
foreach(reader IN LISTS readers)
  file(READ ${reader} text)
  string(APPEND code "${text}")
endforeach()
file(READ ${DOCS}/experiment.md page)
file(READ ${DOCS}/experiment_more.md more)
string(APPEND page "${more}")
# These mean something in a CMake list.
string(REGEX REPLACE "[][;]" " " code "${code}")
string(REGEX REPLACE "[][;]" " " page "${page}")

# A key is the first thing in quotes of a call, perhaps behind names: keys.number("rate_hz"), cutoff(keys,
# "cutoff_hz"), file_at(inner, *table, "table", folder). Messages have blanks and so are no keys.
set(known "")
string(REGEX MATCHALL "[a-z_]+(<[a-z_:<>0-9, ]+>)?\\([ \n]*(\\*?[a-z_]+, *)*\"[A-Za-z_0-9]+\"" calls "${code}")
foreach(call IN LISTS calls)
  string(REGEX REPLACE ".*\"([A-Za-z_0-9]+)\"" "\\1" key "${call}")
  list(APPEND known ${key})
endforeach()
list(REMOVE_DUPLICATES known)
list(LENGTH known count)
if(count LESS 25)
  message(FATAL_ERROR "check_experiment_page: only ${count} keys found in the readers, which look up more than 25")
endif()

# Items of lists and rows of tables: - `key` (…, | `key` | …
set(told "")
string(REGEX MATCHALL "\n[-|] `[A-Za-z_0-9]+` [(|]" rows "${page}")
foreach(row IN LISTS rows)
  string(REGEX REPLACE ".*`([A-Za-z_0-9]+)`.*" "\\1" key "${row}")
  list(APPEND told ${key})
endforeach()
list(REMOVE_DUPLICATES told)

set(faults 0)
foreach(key IN LISTS known)
  string(FIND "${page}" "\n## ` ${key} `\n" heading)
  if(NOT key IN_LIST told AND heading EQUAL -1)
    math(EXPR faults "${faults} + 1")
    message(NOTICE "docs/experiment.md: no list, no table and no heading has the key ${key}, which the reader knows")
  endif()
endforeach()
if(faults)
  message(FATAL_ERROR "check_experiment_page: ${faults} keys are missing")
endif()
message(STATUS "check_experiment_page: ${count} keys are on the page")
