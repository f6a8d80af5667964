#include "report/page_tables.hpp"

#include "experiment/json_fields.hpp"
#include "experiment/sections.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/simulate/control_laws.hpp"

namespace rivid::detail {

namespace {

// Kinds of values that TomlReader takes for a type.
template <typename Value>
struct KindsOf {
  static void add(std::vector<ValueKind>& out) {
    using enum ValueKind;
    if constexpr (std::is_same_v<Value, bool>) {
      out.push_back(boolean);
    } else if constexpr (std::is_floating_point_v<Value>) {
      out.push_back(number);
    } else if constexpr (std::is_integral_v<Value>) {
      out.push_back(integer);
    } else if constexpr (std::is_enum_v<Value> || std::is_same_v<Value, Word>) {
      out.push_back(word);
    } else if constexpr (std::is_same_v<Value, std::filesystem::path>) {
      out.push_back(file);
    } else if constexpr (std::is_same_v<Value, Vector>) {
      out.insert(out.end(), {number, list});
    } else if constexpr (std::is_same_v<Value, Eigen::Vector3d>) {
      out.push_back(three_numbers);
    } else if constexpr (std::is_same_v<Value, std::array<double, 2>>) {
      out.push_back(two_numbers);
    } else if constexpr (requires { std::tuple_size<Value>::value; }) {
      out.insert(out.end(), {integer, list});
    } else if constexpr (std::is_same_v<Value, Matrix>) {
      out.push_back(lists);
    } else if constexpr (std::is_same_v<Value, rivid::Column>) {
      out.push_back(column);
    } else if constexpr (std::is_convertible_v<Value, std::string>) {
      out.push_back(string);
    } else {
      out.push_back(table);
    }
  }
};
template <typename Value>
struct KindsOf<std::optional<Value>> : KindsOf<Value> {};
template <typename... Values>
struct KindsOf<std::variant<Values...>> {
  static void add(std::vector<ValueKind>& out) { (KindsOf<Values>::add(out), ...); }
};
template <typename Value>
struct KindsOf<std::vector<Value>> {
  static void add(std::vector<ValueKind>& out) {
    if constexpr (std::is_same_v<Value, rivid::Column>) {
      out.push_back(ValueKind::columns);
    } else if constexpr (!std::is_convertible_v<Value, std::string> && std::is_class_v<Value> &&
                         !std::is_same_v<Value, std::filesystem::path>) {
      out.push_back(ValueKind::tables);
    } else {
      KindsOf<Value>::add(out);
      out.push_back(ValueKind::list);
    }
  }
};

// Names of the values that are enumerated.
template <typename Value>
void add_words(std::vector<std::string>& out, const std::type_identity<Value>& /*of*/) {
  if constexpr (Named<Value>) {
    out.insert(out.end(), names_of<Value>.begin(), names_of<Value>.end());
  }
}
template <typename Value>
void add_words(std::vector<std::string>& out, const std::type_identity<std::vector<Value>>& /*of*/) {
  add_words(out, std::type_identity<Value>());
}
template <typename... Values>
void add_words(std::vector<std::string>& out, const std::type_identity<std::variant<Values...>>& /*of*/) {
  (add_words(out, std::type_identity<Values>()), ...);
}

// "integers or `"auto"`": one for all joints, or a list.
std::string in_words(const std::vector<ValueKind>& kinds, std::string_view word) {
  std::vector<std::string> parts;
  for (const ValueKind kind : kinds) {
    if (kind == ValueKind::list) {
      parts.back() += 's';
    } else {
      parts.emplace_back(rivid::name(kind));
    }
  }
  if (!word.empty()) {
    parts.push_back("`\"" + std::string(word) + "\"`");
  }
  std::string out = parts.front();
  for (std::size_t i = 1; i < parts.size(); ++i) {
    out += (i + 1 == parts.size() ? " or " : ", ") + parts[i];
  }
  return out;
}

// A value as a page shows it, whole numbers without a point.
std::string code(const Json& value) {
  if (value.is_null() || value == Json("") || (value.is_array() && value.empty())) {
    return "–";
  }
  std::string text = value.dump();
  if (value.is_number() && text.ends_with(".0")) {
    text.resize(text.size() - 2);
  }
  return "`" + text + "`";
}

// Lines of a table of keys.
class KeyTable {
 public:
  template <typename Record, typename... Accesses>
  KeyTable& add(const std::tuple<Field<Accesses>...>& fields) {
    std::apply([&](const auto&... field) { (add_row<Record>(field), ...); }, fields);
    return *this;
  }
  template <Described Record>
  KeyTable& add() {
    return add<Record>(Record::fields());
  }

  [[nodiscard]] const std::vector<KeyRow>& rows() const { return rows_; }

 private:
  template <typename Record, typename Access>
  void add_row(const Field<Access>& field) {
    using Value = KeyValue<Access, Record>;
    const FieldDetails& d = field.details;
    if constexpr (Described<Value> && std::is_member_object_pointer_v<Access>) {
      if (field.key.empty()) {
        add<Value>();
        return;
      }
    }
    KeyRow row{.key = std::string(field.key),
               .otherwise = std::string(d.required.empty() ? d.otherwise : "required"),
               .unit = std::string(d.unit),
               .meaning = std::string(field.meaning),
               .range = d.range};
    KindsOf<Value>::add(row.kinds);
    if (!d.words[0].empty()) {
      row.kinds.front() = ValueKind::word;
    }
    row.type = in_words(row.kinds, d.word);
    if constexpr (is_shown<Access, Record>) {
      if (row.otherwise.empty()) {
        const Record fresh;  // g++ 12 warns of "Record{}" without reason
        row.otherwise = code(json_of(field, fresh));
      }
    }
    add_words(row.words, std::type_identity<Value>());
    for (const std::string_view word : {d.words[0], d.words[1], d.word}) {
      if (!word.empty()) {
        row.words.emplace_back(word);
      }
    }
    rows_.push_back(std::move(row));
  }

  std::vector<KeyRow> rows_;
};

template <typename... Laws>
void add_laws(std::map<std::string, KeyTable>& out, const std::tuple<Laws...>*) {
  (out["control." + std::string(Laws::word)].template add<Laws>(), ...);
}

std::map<std::string, KeyTable> key_tables() {
  std::map<std::string, KeyTable> out;
  out["robot"].add<Robot>(robot_keys).add<Joint>();
  out["robot.joints"].add<Joint>(Joint::a_priori()).add<Joint>(Joint::twin());
  out["robot.dependent"].add<DependentJoint>();
  out["robot.four_bar"].add<FourBar>();
  out["robot.coupling"].add<Coupling>().add<Coupling>(Coupling::a_priori());
  out["log"].add<LogSource>();
  out["log.column"].add<rivid::Column>();
  out["log.subtract"].add<LogSource::Subtraction>();
  out["log.base"].add<LogSource::BasePose>();
  out["log.contact"].add<LogSource::Contact>();
  out["log.reference_file"].add<LogSource::Reference>();
  out["signal"].add<SignalOptions>();
  out["method"].add<Estimation>(method_keys).add<CovarianceOptions>().add<Robust>();
  out["method.iv"].add<Iv>().add<Iv>(iv_keys);
  out["method.physical"].add<Physical>();
  out["method.essential"].add<Essential>();
  out["method.gains"].add<GainOptions>().add<GainOptions>(gain_keys);
  out["control"]
      .add<ControlLoop>(control_keys)
      .add<PdControl>(pole_fields<PdControl>())
      .add<ControlLoop>()
      .add<Sampling>();
  add_laws(out, static_cast<const ControlLaws*>(nullptr));
  out["reference"].add<ReferenceSource>(reference_keys);
  out["reference.logged"].add<LoggedMotion>();
  out["reference.fourier"].add<FourierSeries>();
  out["reference.point_to_point"].add<PointToPoint>();
  out["simulation"].add<SimulationPlan>();
  out["simulation.added_control"].add<SimulationPlan::AddedControl>();
  out["excitation"].add<ExcitationPlan>();
  out["excitation.target"].add<ExcitationTarget>();
  out["excitation.limits"].add<MotionLimits>();
  out["excitation.space"].add<Space>();
  out["excitation.half_space"].add<HalfSpace>();
  out["excitation.box"].add<Box>();
  out["excitation.capsule"].add<Capsule>();
  out["excitation.link_pair"].add<LinkPair>();
  out["montecarlo"].add<MonteCarlo>();
  out["montecarlo.trial"].add<MonteCarlo::Trial>(trial_keys);
  return out;
}

}  // namespace

std::map<std::string, std::vector<KeyRow>> key_rows() {
  std::map<std::string, std::vector<KeyRow>> out;
  for (const auto& [name, table] : key_tables()) {
    out[name] = table.rows();
  }
  return out;
}

}  // namespace rivid::detail
