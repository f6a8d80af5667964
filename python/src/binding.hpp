#pragma once

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "rivid/identify/estimation.hpp"

/// In place of nanobind/stl/string.h, which raises UnicodeDecodeError: names from files, and pages that show
/// them, may be no UTF-8. Such bytes are '?', as the tools show them.
template <>
struct nanobind::detail::type_caster<std::string> {
  NB_TYPE_CASTER(std::string, const_name("str"))

  bool from_python(handle src, std::uint8_t /*flags*/, cleanup_list* /*cleanup*/) noexcept {
    Py_ssize_t size = 0;
    const char* const text = PyUnicode_AsUTF8AndSize(src.ptr(), &size);
    if (text == nullptr) {
      PyErr_Clear();
      return false;
    }
    value = std::string(text, static_cast<std::size_t>(size));
    return true;
  }

  static handle from_cpp(const std::string& text, rv_policy /*policy*/, cleanup_list* /*cleanup*/) noexcept {
    const auto size = static_cast<Py_ssize_t>(text.size());
    if (PyObject* const whole = PyUnicode_FromStringAndSize(text.data(), size); whole != nullptr) {
      return whole;
    }
    PyErr_Clear();
    const object damaged = steal(PyUnicode_DecodeUTF8(text.data(), size, "replace"));
    const object unknown = steal(PyUnicode_FromString("\xEF\xBF\xBD"));
    const object shown = steal(PyUnicode_FromString("?"));
    return PyUnicode_Replace(damaged.ptr(), unknown.ptr(), shown.ptr(), -1);
  }
};

// What the files of the extension share. Options come as TOML text in the words of experiment files and
// results go as the JSON documents that the tools write: neither is described here again.
namespace rivid::python {

namespace nb = nanobind;
using namespace nb::literals;

/// Lets other threads of Python run.
using Unlocked = nb::call_guard<nb::gil_scoped_release>;

/// Where long work calls Python now and then: an interrupt ends it, and a callback hears how far it is. The
/// callback must outlive the work, which holds no lock of Python meanwhile.
class Listener {
 public:
  explicit Listener(const nb::object& callback) : callback_(&callback) {}

  void operator()(std::string_view stage, double fraction) const {
    const nb::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) {
      throw nb::python_error();
    }
    if (!callback_->is_none()) {
      (*callback_)(nb::str(stage.data(), stage.size()), fraction);
    }
  }

 private:
  const nb::object* callback_;
};

/// A matrix of an object as an array that reads its memory.
inline Eigen::Map<const Matrix> view(const Matrix& m) { return {m.data(), m.rows(), m.cols()}; }
inline Eigen::Map<const Vector> view(const Vector& v) { return {v.data(), v.size()}; }

/// A read-only array of a member, which keeps its object alive.
template <typename Class, typename Member>
void def_array(Class& type, const char* name, Member member, const char* text) {
  using Owner = typename Class::Type;
  type.def_prop_ro(
      name, [member](const Owner& self) { return view(self.*member); }, nb::rv_policy::reference_internal,
      text);
}

void bind_data(nb::module_& m);
void bind_identify(nb::module_& m);
void bind_factors(nb::module_& m);
void bind_dynamics(nb::module_& m);
void bind_experiment(nb::module_& m);
void bind_online(nb::module_& m);
void bind_payload(nb::module_& m);

}  // namespace rivid::python
