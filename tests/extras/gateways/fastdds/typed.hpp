// A message of messages.hpp as a type that Fast DDS can send and receive.
#pragma once

#include <functional>

#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include "messages.hpp"

template <class Message>
class Typed : public eprosima::fastdds::dds::TopicDataType {
 public:
  Typed() {
    setName(Message::name);
    m_typeSize = kLargest;
    m_isGetKeyDefined = false;
  }

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    Buffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    payload->encapsulation = CDR_LE;
    cdr.serialize_encapsulation();
    static_cast<Message*>(data)->write(cdr);
    payload->length = static_cast<uint32_t>(cdr.getSerializedDataLength());
    return true;
  }

  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    Buffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    try {
      cdr.read_encapsulation();
      static_cast<Message*>(data)->read(cdr);
    } catch (const eprosima::fastcdr::exception::Exception&) {
      return false;
    }
    return true;
  }

  std::function<uint32_t()> getSerializedSizeProvider(void*) override {
    return [] { return kLargest; };
  }

  void* createData() override { return new Message; }
  void deleteData(void* data) override { delete static_cast<Message*>(data); }

  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }

 private:
  using Buffer = eprosima::fastcdr::FastBuffer;
  static constexpr uint32_t kLargest = 64 * 1024;
};
