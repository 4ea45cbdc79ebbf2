// A program on the other side: it listens to the drone and flies it, by Fast DDS.
//
//   peer DOMAIN            flies by Twist
//   peer DOMAIN FRAME      flies by TwistStamped in this frame
//
// It prints a line for each message that it gets, its topic first, and sends what it reads:
//
//   fly X Y Z YAW_RATE     this velocity from now on, 20 times a second
//   silent                 nothing from now on
//   do WORDS               a flight operation, once
//   call                   the service that arms, once
//
// It ends with its input. As a node of ROS 2 that is told to stay on its computer, it speaks by the
// loopback interface only, and looks for others at the first ports there.

#include <atomic>
#include <chrono>
#include <functional>
#include <iostream>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include "typed.hpp"

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

class Peer {
 public:
  explicit Peer(int domain)
      : participant_(factory().create_participant(domain, on_this_computer())),
        subscriber_(participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)),
        publisher_(participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT)) {}

  ~Peer() {
    participant_->delete_contained_entities();
    factory().delete_participant(participant_);
  }

  // Let `print` print each message of a topic.
  template <class Message>
  void listen(const std::string& topic, std::function<void(const Message&)> print,
              fast::DurabilityQosPolicyKind durability = fast::VOLATILE_DURABILITY_QOS) {
    fast::DataReaderQos qos;
    qos.durability().kind = durability;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = 10;
    fast::DataReader* reader = subscriber_->create_datareader(make<Message>(topic), qos);
    turns_.push_back([topic, reader, print] {
      Message message;
      fast::SampleInfo info;
      while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
        if (!info.valid_data) continue;
        std::cout << topic.substr(2) << " ";
        print(message);
        std::cout << std::endl;
      }
    });
  }

  template <class Message>
  fast::DataWriter* writer(const std::string& topic) {
    fast::DataWriterQos qos;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = 10;
    return publisher_->create_datawriter(make<Message>(topic), qos);
  }

  void take_turns() {
    for (auto& turn : turns_) turn();
  }

 private:
  static fast::DomainParticipantQos on_this_computer() {
    fast::DomainParticipantQos qos;
    auto transport = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    transport->interfaceWhiteList.push_back("127.0.0.1");
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(transport);
    rtps::Locator_t here;
    rtps::IPLocator::setIPv4(here, 127, 0, 0, 1);
    qos.wire_protocol().builtin.metatrafficUnicastLocatorList.push_back(here);
    qos.wire_protocol().builtin.initialPeersList.push_back(here);
    return qos;
  }

  static fast::DomainParticipantFactory& factory() {
    return *fast::DomainParticipantFactory::get_instance();
  }

  template <class Message>
  fast::Topic* make(const std::string& topic) {
    fast::TypeSupport type(new Typed<Message>);
    type.register_type(participant_);
    return participant_->create_topic(topic, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  }

  fast::DomainParticipant* participant_;
  fast::Subscriber* subscriber_;
  fast::Publisher* publisher_;
  std::vector<std::function<void()>> turns_;
};

int main(int count, char** words) {
  if (count != 2 && count != 3) {
    std::cerr << "usage: peer DOMAIN [FRAME]" << std::endl;
    return 2;
  }
  const bool stamped = count == 3;
  Peer peer(std::stoi(words[1]));
  peer.listen<Odometry>("rt/dh_drone/odometry", [](const Odometry& m) {
    std::cout << m.header.stamp.sec << " " << m.header.stamp.nanosec << " " << m.header.frame_id
              << " " << m.child_frame_id << " " << m.position.x << " " << m.position.y << " "
              << m.position.z << " " << m.orientation.z << " " << m.orientation.w << " "
              << m.twist.linear.x << " " << m.twist.linear.y << " " << m.twist.angular.z;
  });
  peer.listen<PositionData>("rt/dh_drone/position_data", [](const PositionData& m) {
    std::cout << m.header.frame_id;
    for (float number : m.numbers) std::cout << " " << number;
  });
  auto print_transforms = [](const TFMessage& m) {
    for (const TransformStamped& each : m.transforms) {
      std::cout << each.header.frame_id << " " << each.child_frame_id << " " << each.translation.z
                << " " << each.rotation.w << " ";
    }
  };
  peer.listen<TFMessage>("rt/tf", print_transforms);
  peer.listen<TFMessage>("rt/tf_static", print_transforms, fast::TRANSIENT_LOCAL_DURABILITY_QOS);
  peer.listen<String>("rt/dh_drone/robot_description", [](const String& m) {
    std::cout << m.data;
  }, fast::TRANSIENT_LOCAL_DURABILITY_QOS);
  peer.listen<TriggerResponse>("rr/dh_drone/armReply", [](const TriggerResponse& m) {
    std::cout << m.client << " " << m.sequence << " " << m.success << " " << m.message;
  });
  peer.listen<Clock>("rt/clock", [](const Clock& m) {
    std::cout << m.clock.sec << " " << m.clock.nanosec;
  });
  fast::DataWriter* velocities = stamped ? peer.writer<TwistStamped>("rt/dh_drone/cmd_vel")
                                         : peer.writer<Twist>("rt/dh_drone/cmd_vel");
  fast::DataWriter* requests = peer.writer<TriggerRequest>("rq/dh_drone/armRequest");
  fast::DataWriter* operations = peer.writer<String>("rt/dh_drone/flight_operation");

  std::mutex mutex;
  bool flies = false;
  TwistStamped velocity;
  if (stamped) velocity.header.frame_id = words[2];
  std::atomic<bool> ended{false};
  std::thread input([&] {
    std::string line;
    while (std::getline(std::cin, line)) {
      std::istringstream text(line);
      std::string word;
      text >> word;
      std::lock_guard<std::mutex> lock(mutex);
      if (word == "do") {
        String operation;
        operation.data = line.substr(3);
        operations->write(&operation);
      } else if (word == "call") {
        TriggerRequest request;
        requests->write(&request);
      } else {
        flies = word == "fly";
        Twist& twist = velocity.twist;
        text >> twist.linear.x >> twist.linear.y >> twist.linear.z >> twist.angular.z;
      }
    }
    ended = true;
  });
  for (int turn = 0; !ended; ++turn) {
    peer.take_turns();
    if (turn % 5 == 0) {
      std::lock_guard<std::mutex> lock(mutex);
      void* message = stamped ? static_cast<void*>(&velocity) : &velocity.twist;
      if (flies) velocities->write(message);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  input.join();
}
