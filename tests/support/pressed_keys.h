// Keys and buttons pressed on a virtual display from the test's own process, as by XTest.
#pragma once

#include <memory>
#include <string>

namespace springdrive::testing {

class PressedKeys {
public:
    /// @throw std::runtime_error  there is no such display
    explicit PressedKeys(const std::string &display);
    ~PressedKeys();
    PressedKeys(const PressedKeys &) = delete;
    PressedKeys &operator=(const PressedKeys &) = delete;

    // They return when the server has them; keys are called as in X11's keysymdef.h.
    void tap(const std::string &key);
    void click(int x, int y, int button = 1);

private:
    struct Connection;
    std::unique_ptr<Connection> connection_;
};

} // namespace springdrive::testing
