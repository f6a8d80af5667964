# check_layering.cmake must find what it is there to find: each case is a small source tree made here.

set(cases 0)
# case(INSIDE "file" LINE "second line of that file" [FAILS_WITH regex])
function(case)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "INSIDE;LINE;FAILS_WITH" "")
  math(EXPR number "${cases} + 1")
  set(cases ${number} PARENT_SCOPE)
  set(tree ${WORK_DIR}/${number})
  file(REMOVE_RECURSE ${tree})
  file(WRITE ${tree}/include/rivid/types.hpp "#pragma once\n")
  file(WRITE ${tree}/${arg_INSIDE} "// A list[0]; a \\ and an unbalanced [ as C++ has them\n${arg_LINE}\n")
  execute_process(
    COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${tree} -P ${CHECK}
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output
    RESULT_VARIABLE result)
  if(arg_FAILS_WITH)
    if(result EQUAL 0 OR NOT output MATCHES "${arg_FAILS_WITH}")
      message(FATAL_ERROR "case ${number}, ${arg_INSIDE}: should fail with \"${arg_FAILS_WITH}\", got:\n${output}")
    endif()
  elseif(NOT result EQUAL 0)
    message(FATAL_ERROR "case ${number}, ${arg_INSIDE}: should pass, got:\n${output}")
  endif()
endfunction()

case(INSIDE include/rivid/regressor/a.hpp LINE "#include \"rivid/model/chain.hpp\"")
case(INSIDE src/identify/a.cpp LINE "#include \"rivid/types.hpp\"")
case(INSIDE src/identify/infer/a.cpp LINE "#include \"identify/estimate/a.hpp\"")
case(INSIDE src/solve/a.cpp LINE "#include \"solve/kernel.hpp\"")
case(INSIDE include/rivid/rivid.hpp LINE "#include \"rivid/report/json.hpp\"")
case(INSIDE include/rivid/solve/a.hpp LINE "#include \"rivid/model/robot.hpp\""
     FAILS_WITH "include/rivid/solve/a.hpp:2: solve must not include rivid/model/robot.hpp; it may include no other")
case(INSIDE src/report/a.cpp LINE "  #  include <rivid/solve/streaming_qr.hpp>"
     FAILS_WITH "src/report/a.cpp:2: report must not include .*; it may include model, regressor, data, identify")
case(INSIDE src/signal/a.cpp LINE "#include \"solve/kernel.hpp\"" FAILS_WITH "a.cpp:2: signal must not include solve/")
case(INSIDE src/identify/rows/a.cpp LINE "#include \"identify/estimate/a.hpp\""
     FAILS_WITH "a.cpp:2: identify/rows must not include identify/estimate/a.hpp")
case(INSIDE src/identify/rows/a.hpp LINE "class Rows final : public Sink {\nclass Rows {" FAILS_WITH "a.hpp:3: there is a class Rows")
case(INSIDE src/identify/estimate/a.cpp LINE "#include \"identify/infer/a.hpp\""
     FAILS_WITH "a.cpp:2: identify/estimate must not include identify/infer/a.hpp")
case(INSIDE src/identify/attic/a.cpp LINE "" FAILS_WITH "a.cpp:1: room attic of identify is not in the table")
case(INSIDE include/rivid/error.hpp LINE "#include \"rivid/model/robot.hpp\"" FAILS_WITH "error.hpp:2: a root header")
case(INSIDE include/rivid/data/a.hpp LINE "#include \"rivid/rivid.hpp\"" FAILS_WITH "a.hpp:2: rivid/rivid.hpp is for")
case(INSIDE include/rivid/data/a.hpp LINE "#include \"../error.hpp\"" FAILS_WITH "a.hpp:2: ../error.hpp: paths")
case(INSIDE include/rivid/data/a.hpp LINE "#include \"rivid/util/a.hpp\"" FAILS_WITH "a.hpp:2: .*module util is not")
case(INSIDE src/util/a.cpp LINE "" FAILS_WITH "a.cpp:1: module util is not in the table")

message(STATUS "${cases} cases, each judged rightly")
