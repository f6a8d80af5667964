#include "pinocchio_aba.hpp"

#include <pinocchio/multibody.hpp>
// After the model.
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <string>

struct PinocchioAba::Impl {
  pinocchio::Model model;
  pinocchio::Data data;
};

PinocchioAba::PinocchioAba(const std::vector<Link>& links, const std::array<double, 3>& gravity)
    : impl_(std::make_unique<Impl>()) {
  pinocchio::Model& model = impl_->model;
  pinocchio::JointIndex parent = 0;
  for (std::size_t j = 0; j < links.size(); ++j) {
    const Link& link = links[j];
    const pinocchio::SE3 placement(Eigen::Matrix3d(Eigen::Matrix3d::Map(link.R.data())),
                                   Eigen::Vector3d(Eigen::Vector3d::Map(link.p.data())));
    const std::string name = "joint_" + std::to_string(j + 1);
    parent = link.revolute ? model.addJoint(parent, pinocchio::JointModelRZ(), placement, name)
                           : model.addJoint(parent, pinocchio::JointModelPZ(), placement, name);
    using Ten = Eigen::Matrix<double, 10, 1>;
    model.appendBodyToJoint(
        parent, pinocchio::Inertia::FromDynamicParameters(Ten(Ten::Map(link.dynamic_parameters.data()))));
    model.armature[static_cast<Eigen::Index>(j)] = link.Ia;
  }
  model.gravity.linear() = Eigen::Vector3d::Map(gravity.data());
  impl_->data = pinocchio::Data(model);
}

PinocchioAba::~PinocchioAba() = default;

const double* PinocchioAba::operator()(const double* q, const double* qd, const double* tau) {
  using Values = Eigen::Map<const Eigen::VectorXd>;
  const Eigen::Index n = impl_->model.nv;
  return pinocchio::aba(impl_->model, impl_->data, Values(q, n), Values(qd, n), Values(tau, n)).data();
}

const double* PinocchioAba::torques(const double* q, const double* qd, const double* qdd) {
  using Values = Eigen::Map<const Eigen::VectorXd>;
  const Eigen::Index n = impl_->model.nv;
  return pinocchio::rnea(impl_->model, impl_->data, Values(q, n), Values(qd, n), Values(qdd, n)).data();
}
