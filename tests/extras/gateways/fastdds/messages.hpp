// The messages that this program speaks, written by hand, apart from what the gateway is made of.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <fastcdr/Cdr.h>

using eprosima::fastcdr::Cdr;

struct Time {
  int32_t sec = 0;
  uint32_t nanosec = 0;
  void read(Cdr& cdr) { cdr >> sec >> nanosec; }
  void write(Cdr& cdr) const { cdr << sec << nanosec; }
};

struct Header {
  Time stamp;
  std::string frame_id;
  void read(Cdr& cdr) { stamp.read(cdr), cdr >> frame_id; }
  void write(Cdr& cdr) const { stamp.write(cdr), cdr << frame_id; }
};

struct Vector3 {
  double x = 0, y = 0, z = 0;
  void read(Cdr& cdr) { cdr >> x >> y >> z; }
  void write(Cdr& cdr) const { cdr << x << y << z; }
};

struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
  void read(Cdr& cdr) { cdr >> x >> y >> z >> w; }
};

struct Twist {
  static constexpr const char* name = "geometry_msgs::msg::dds_::Twist_";
  Vector3 linear, angular;
  void read(Cdr& cdr) { linear.read(cdr), angular.read(cdr); }
  void write(Cdr& cdr) const { linear.write(cdr), angular.write(cdr); }
};

struct TwistStamped {
  static constexpr const char* name = "geometry_msgs::msg::dds_::TwistStamped_";
  Header header;
  Twist twist;
  void read(Cdr& cdr) { header.read(cdr), twist.read(cdr); }
  void write(Cdr& cdr) const { header.write(cdr), twist.write(cdr); }
};

// Requests and responses of std_srvs/srv/Trigger, with the header of rmw_cyclonedds_cpp.
struct TriggerRequest {
  static constexpr const char* name = "std_srvs::srv::dds_::Trigger_Request_";
  uint64_t client = 4711;
  int64_t sequence = 1;
  void read(Cdr&) {}
  void write(Cdr& cdr) const { cdr << client << sequence << uint8_t(0); }
};

struct TriggerResponse {
  static constexpr const char* name = "std_srvs::srv::dds_::Trigger_Response_";
  uint64_t client = 0;
  int64_t sequence = 0;
  bool success = false;
  std::string message;
  void read(Cdr& cdr) { cdr >> client >> sequence >> success >> message; }
  void write(Cdr&) const {}
};

struct Odometry {
  static constexpr const char* name = "nav_msgs::msg::dds_::Odometry_";
  Header header;
  std::string child_frame_id;
  Vector3 position;
  Quaternion orientation;
  std::array<double, 36> pose_covariance{};
  Twist twist;
  std::array<double, 36> twist_covariance{};
  void read(Cdr& cdr) {
    header.read(cdr), cdr >> child_frame_id;
    position.read(cdr), orientation.read(cdr), cdr >> pose_covariance;
    twist.read(cdr), cdr >> twist_covariance;
  }
  void write(Cdr&) const {}
};

struct PositionData {
  static constexpr const char* name = "dh_drone_msgs::msg::dds_::PositionData_";
  Header header;
  std::array<float, 9> numbers{};  // x, y, z, roll, pitch, yaw, displacement x, y, z
  void read(Cdr& cdr) {
    header.read(cdr);
    for (float& number : numbers) cdr >> number;
  }
  void write(Cdr&) const {}
};

struct TransformStamped {
  Header header;
  std::string child_frame_id;
  Vector3 translation;
  Quaternion rotation;
  void read(Cdr& cdr) {
    header.read(cdr), cdr >> child_frame_id;
    translation.read(cdr), rotation.read(cdr);
  }
};

struct TFMessage {
  static constexpr const char* name = "tf2_msgs::msg::dds_::TFMessage_";
  std::vector<TransformStamped> transforms;
  void read(Cdr& cdr) {
    uint32_t count = 0;
    cdr >> count;
    transforms.assign(count, {});
    for (TransformStamped& each : transforms) each.read(cdr);
  }
  void write(Cdr&) const {}
};

struct Clock {
  static constexpr const char* name = "rosgraph_msgs::msg::dds_::Clock_";
  Time clock;
  void read(Cdr& cdr) { clock.read(cdr); }
  void write(Cdr&) const {}
};

struct String {
  static constexpr const char* name = "std_msgs::msg::dds_::String_";
  std::string data;
  void read(Cdr& cdr) { cdr >> data; }
  void write(Cdr& cdr) const { cdr << data; }
};
