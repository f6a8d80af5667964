#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "binding.hpp"
#include "report/page_tables.hpp"
#include "rivid/error.hpp"
#include "rivid/finding.hpp"
#include "rivid/input.hpp"
#include "rivid/output.hpp"
#include "rivid/report/text.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid::python {

namespace {

// Rows of the tables of docs/experiment.md: key, kinds of its values, default, unit, meaning, words.
using OptionRow = std::tuple<std::string, std::vector<std::string>, std::string, std::string, std::string,
                             std::vector<std::string>>;

std::map<std::string, std::vector<OptionRow>> option_tables() {
  std::map<std::string, std::vector<OptionRow>> out;
  for (const auto& [name, rows] : detail::key_rows()) {
    for (const detail::KeyRow& row : rows) {
      std::vector<std::string> kinds;
      for (const detail::ValueKind kind : row.kinds) {
        kinds.emplace_back(rivid::name(kind));
      }
      out[name].emplace_back(row.key, kinds, row.otherwise, row.unit, row.meaning, row.words);
    }
  }
  return out;
}

// As the tools write their outputs. What says that a file is of another kind knows no --force here.
void write_output(const std::filesystem::path& path, std::string_view content, const std::string& extension,
                  const std::vector<std::filesystem::path>& inputs) {
  Outputs outputs(inputs, true);
  outputs.plan(path, extension);
  std::error_code error;
  if (const auto there = std::filesystem::canonical(path, error); !error && there.extension() != extension) {
    throw InputError(path.string() + ": is there already and is no " + extension +
                     " file; name another file, or remove this one");
  }
  outputs.put(path, content);
  outputs.commit();
}

// In place of nanobind's own, which takes messages for UTF-8: they show names from files, as the tools do.
template <typename E>
void translate(const nb::exception<E>& type) {
  nb::register_exception_translator(
      [](const std::exception_ptr& error, void* type) {
        try {
          std::rethrow_exception(error);
        } catch (const E& e) {
          PyErr_SetString(static_cast<PyObject*>(type), on_one_line(e.what()).c_str());
        }
      },
      type.ptr());
}

void bind_errors(nb::module_& m) {
  const nb::exception<Error> error(m, "Error");
  // What cannot be used is a ValueError too, what gave up an ArithmeticError.
  const auto also = [&](PyObject* other) { return nb::make_tuple(error, nb::borrow(other)); };
  const nb::exception<InputError> input(m, "InputError", also(PyExc_ValueError));
  const nb::exception<NumericsError> numerics(m, "NumericsError", also(PyExc_ArithmeticError));
  translate(error);  // the newest is asked first
  translate(input);
  translate(numerics);
}

}  // namespace

}  // namespace rivid::python

NB_MODULE(_rivid, m) {
  using namespace rivid::python;
  m.doc() = "The C++ library of rivid, as thin as it goes; the package rivid is the interface.";
  m.attr("version") = rivid::version;
  // A session of IPython ends with all that it holds, which nanobind would take for leaks.
  nanobind::set_leak_warnings(false);
  bind_errors(m);
  m.def("option_tables", &option_tables,
        "Keys of experiment files, table by table: (key, kinds, default, unit, meaning, words).");
  m.def(
      "explanation",
      [](const std::string& code) -> std::optional<std::string> {
        const auto known = rivid::diagnostic_code(code);
        return known ? std::optional(rivid::explained(*known)) : std::nullopt;
      },
      "code"_a, "Cause and cure of a code of a finding; None for an unknown one.");
  m.def("write_file", &write_output, "path"_a, "content"_a, "extension"_a, "inputs"_a, Unlocked(),
        "Writes a file as a whole or not at all, over none of the inputs and no file of another extension.");
  m.def("limit_inputs", &rivid::limit_inputs, "most_bytes"_a, "Sets the largest text file that is read.");
  m.def(
      "read_input",
      [](const std::filesystem::path& path) { return std::string(rivid::read_input(path).bytes()); },
      "path"_a, "The text of a file, as the library reads it.");
  bind_data(m);
  bind_dynamics(m);
  bind_identify(m);
  bind_online(m);
  bind_payload(m);
  bind_factors(m);
  bind_experiment(m);
}
