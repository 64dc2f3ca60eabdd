// What changes a servo's inputs from tick to tick, such as a stimulus that answers to the touch: a
// mailbox would be late by a frame.
#pragma once

namespace springdrive::servo {

struct LawInputs;
struct ServoSample;

class InputCourse {
public:
    InputCourse() = default;
    virtual ~InputCourse() = default;
    InputCourse(const InputCourse &) = delete;
    InputCourse &operator=(const InputCourse &) = delete;

    /// After a tick: changes what the law is to do in the next one. `next` is as published.
    /// RT-safe.
    virtual void update(const ServoSample &last, LawInputs &next) noexcept = 0;
};

} // namespace springdrive::servo
