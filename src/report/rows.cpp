#include "rivid/report/rows.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

#include "dense.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/instruments.hpp"
#include "rivid/identify/robust.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Diagonal of A (AᵀA)⁻¹ Aᵀ.
Vector hat_diagonal(const Matrix& A) {
  Matrix factored = A;
  const Matrix R = detail::triangular_factor(factored);
  const Vector diagonal = R.diagonal().cwiseAbs();
  if (A.rows() < A.cols() ||
      diagonal.minCoeff() <= std::numeric_limits<double>::epsilon() * diagonal.maxCoeff()) {
    return Vector::Constant(A.rows(), std::numeric_limits<double>::quiet_NaN());
  }
  const Matrix Q = R.topRows(A.cols()).triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(A);
  return Q.rowwise().squaredNorm();
}

void append_number(std::string& to, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) {
    to += static_cast<char>((value >> (8 * i)) & 0xFF);
  }
}

// CRC-32 of ISO 3309, as zip archives have it.
std::uint32_t checksum(std::string_view bytes) {
  static const auto table = [] {
    std::array<std::uint32_t, 256> out{};
    for (std::uint32_t i = 0; i < out.size(); ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) {
        value = (value & 1U) != 0 ? 0xEDB88320U ^ (value >> 1) : value >> 1;
      }
      out[i] = value;
    }
    return out;
  }();
  std::uint32_t out = 0xFFFFFFFFU;
  for (const char c : bytes) {
    out = table[(out ^ static_cast<unsigned char>(c)) & 0xFFU] ^ (out >> 8);
  }
  return ~out;
}

// An array in the format of NumPy, version 1.0.
std::string npy(const std::string& type, const std::string& shape, std::string_view data) {
  std::string header = "{'descr': '" + type + "', 'fortran_order': True, 'shape': (" + shape + "), }";
  constexpr std::size_t alignment = 64;
  constexpr std::size_t before = 10;
  header.resize((before + header.size() + alignment) / alignment * alignment - before - 1, ' ');
  header += '\n';
  std::string out = "\x93NUMPY";
  out += '\x01';
  out += '\0';
  append_number(out, header.size(), 2);
  return out.append(header).append(data);
}

std::string npy(const Matrix& values, bool vector) {
  static_assert(std::endian::native == std::endian::little, "NumPy's '<f8' is little-endian");
  const std::string rows = std::to_string(values.rows()) + ",";
  std::string data(static_cast<std::size_t>(values.size()) * sizeof(double), '\0');
  std::memcpy(data.data(), values.data(), data.size());
  return npy("<f8", vector ? rows : rows + " " + std::to_string(values.cols()), data);
}

// UTF-8 as strings of four bytes a character, all of one length.
std::string npy(const std::vector<std::string>& names) {
  std::size_t longest = 1;
  for (const std::string& name : names) {
    longest = std::max(longest, display_width(name));
  }
  std::string data;
  for (const std::string& name : names) {
    std::string text;
    std::uint32_t character = 0;
    for (std::size_t i = 0; i < name.size(); ++i) {
      const auto byte = static_cast<unsigned char>(name[i]);
      const bool continues = (byte & 0xC0U) == 0x80U;
      const unsigned lead = byte < 0x80U ? 0x7FU : byte < 0xE0U ? 0x1FU : byte < 0xF0U ? 0x0FU : 0x07U;
      character = continues ? (character << 6) | (byte & 0x3FU) : byte & lead;
      if (i + 1 == name.size() || (static_cast<unsigned char>(name[i + 1]) & 0xC0U) != 0x80U) {
        append_number(text, character, 4);
      }
    }
    text.resize(4 * longest, '\0');
    data += text;
  }
  return npy("<U" + std::to_string(longest), std::to_string(names.size()) + ",", data);
}

// A zip archive whose members are stored as they are.
class Archive {
 public:
  void add(const std::string& name, const std::string& content) {
    if (out_.size() + content.size() > std::numeric_limits<std::uint32_t>::max() - (1U << 16)) {
      throw InputError("to_npz: the rows make up 4 GiB and more; write them as CSV");
    }
    const std::string member = name + ".npy";
    std::string common;
    append_number(common, 20, 2);          // version that reads it
    append_number(common, 0, 4);           // flags, stored
    append_number(common, 0x00210000, 4);  // 1 January 1980, so that equal rows are equal files
    append_number(common, checksum(content), 4);
    append_number(common, content.size(), 4);
    append_number(common, content.size(), 4);
    append_number(common, member.size(), 2);
    append_number(common, 0, 2);
    append_number(directory_, 0x02014b50, 4);
    append_number(directory_, 20, 2);
    directory_ += common;
    directory_.append(10, '\0');  // no comment, one disk, no attributes
    append_number(directory_, out_.size(), 4);
    directory_ += member;
    append_number(out_, 0x04034b50, 4);
    out_ += common + member + content;
    ++members_;
  }

  [[nodiscard]] std::string finished() {
    const std::size_t start = out_.size();
    out_ += directory_;
    append_number(out_, 0x06054b50, 4);
    append_number(out_, 0, 4);
    append_number(out_, members_, 2);
    append_number(out_, members_, 2);
    append_number(out_, directory_.size(), 4);
    append_number(out_, start, 4);
    append_number(out_, 0, 2);
    return std::move(out_);
  }

 private:
  std::string out_;
  std::string directory_;
  std::uint64_t members_ = 0;
};

Vector robust_weights(const Identification& result, const RowTable& rows) {
  Vector out = Vector::Ones(rows.Y.size());
  if (result.robust) {
    const RobustLoss loss = result.robust->options.loss();
    for (Index i = 0; i < out.size(); ++i) {
      const RobustJoint& joint = result.robust->joints[static_cast<std::size_t>(rows.joint[i])];
      out[i] = loss.weight(rows.residual[i] / joint.scale);
    }
  }
  return out;
}

}  // namespace

RowTable row_table(const Robot& robot, const Identification& result, std::span<const Log> logs) {
  RowTable out;
  for (const BaseParameter& parameter : result.base.parameters) {
    out.parameters.push_back(parameter.name);
  }
  for (const Joint& joint : robot.joints) {
    out.joints.push_back(joint.name);
  }
  std::vector<Rows> all;
  Index count = 0;
  for (const Log& log : logs) {
    out.logs.push_back(log.source);
    all.push_back(rows(robot, result.base, log, result.estimation.signal));
    for (const Vector& Y : all.back().Y) {
      count += Y.size();
    }
  }
  const Index b = result.base.size();
  const std::vector<Observation> V = instrument_rows(robot, result, logs);
  out.W = Matrix::Zero(count, b);
  out.V = Matrix::Zero(V.empty() ? 0 : count, b);
  for (Vector* const each : {&out.t, &out.log, &out.joint, &out.Y, &out.weight}) {
    each->resize(count);
  }
  Index row = 0;
  for (std::size_t l = 0; l < all.size(); ++l) {
    for (std::size_t j = 0; j < all[l].Y.size(); ++j) {
      const JointRows& of_joint = all[l].W.joints[j];
      const Index size = all[l].Y[j].size();
      out.Y.segment(row, size) = all[l].Y[j];
      out.log.segment(row, size).setConstant(static_cast<double>(l));
      out.joint.segment(row, size).setConstant(static_cast<double>(j));
      out.weight.segment(row, size).setConstant(result.weights.empty() ? 1.0 : result.weights[j]);
      for (Index i = 0; i < size; ++i) {
        out.t[row + i] = logs[l].t[all[l].samples[j][static_cast<std::size_t>(i)]];
      }
      for (std::size_t k = 0; k < of_joint.columns.size(); ++k) {
        const auto at = static_cast<Index>(k);
        out.W.col(of_joint.columns[k]).segment(row, size) = of_joint.W.col(at);
        if (!V.empty()) {
          out.V.col(of_joint.columns[k]).segment(row, size) = V[l].joints[j].W.col(at);
        }
      }
      row += size;
    }
  }
  out.chi = result.chi;
  out.covariance = result.C_chi;
  out.prediction = out.W * out.chi;
  out.residual = out.Y - out.prediction;
  out.robust_weight = robust_weights(result, out);
  out.leverage = hat_diagonal(out.weight.cwiseProduct(out.robust_weight.cwiseSqrt()).asDiagonal() * out.W);
  return out;
}

std::string to_npz(const RowTable& rows) {
  Archive out;
  const auto vector = [&](const char* name, const Vector& values) {
    out.add(name, npy(Matrix(values), true));
  };
  vector("t", rows.t);
  vector("log", rows.log);
  vector("joint", rows.joint);
  vector("Y", rows.Y);
  out.add("W", npy(rows.W, false));
  if (rows.V.rows() > 0) {
    out.add("V", npy(rows.V, false));
  }
  vector("weight", rows.weight);
  vector("robust_weight", rows.robust_weight);
  vector("prediction", rows.prediction);
  vector("residual", rows.residual);
  vector("leverage", rows.leverage);
  vector("chi", rows.chi);
  out.add("covariance", npy(rows.covariance, false));
  out.add("parameters", npy(rows.parameters));
  out.add("joints", npy(rows.joints));
  out.add("logs", npy(rows.logs));
  return out.finished();
}

std::string to_csv(const RowTable& rows) {
  std::string out = "t,log,joint,Y,prediction,residual,weight,robust_weight,leverage";
  std::vector<std::pair<std::string, const Matrix*>> matrices = {{",W:", &rows.W}};
  if (rows.V.rows() > 0) {
    matrices.emplace_back(",V:", &rows.V);
  }
  for (const auto& [prefix, matrix] : matrices) {
    for (const std::string& name : rows.parameters) {
      out += prefix + name;
    }
  }
  out += '\n';
  for (Index i = 0; i < rows.Y.size(); ++i) {
    out += exact(rows.t[i]) + ',' + exact(rows.log[i]) + ',' + exact(rows.joint[i]);
    for (const Vector* const each :
         {&rows.Y, &rows.prediction, &rows.residual, &rows.weight, &rows.robust_weight, &rows.leverage}) {
      out += ',' + exact((*each)[i]);
    }
    for (const auto& [prefix, matrix] : matrices) {
      for (Index k = 0; k < matrix->cols(); ++k) {
        out += ',' + exact((*matrix)(i, k));
      }
    }
    out += '\n';
  }
  return out;
}

}  // namespace rivid
