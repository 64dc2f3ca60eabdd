// The thread of the driver's port, with a kernel's USB: libusb allocates on it with each transfer,
// where no other thread does. As on_usb_test.cpp, in its program.
#include "base/input_error.h"
#include "base/real_time_thread.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/driver/usb_device.h"
#include "tests/support/real_time_watch.h"
#include "tests/usb/emulator_process.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

namespace springdrive::usb_test {
namespace {

TEST(HeapOnUsb, ThePortsThreadAllocatesWhereNoOtherDoes) {
    const EmulatorWish wish;
    const EmulatorProcess emulator(wish);
    testing::watch_heaps();
    ASSERT_TRUE(reserve_heaps());
    std::thread([] { static_cast<void>(std::make_unique<std::string>(100, ' ')); }).join();
    std::unique_ptr<usb::UsbDevice> device;
    for (int attempt = 0; !device && attempt < 500; ++attempt) { // it takes a moment to be there
        try {
            device = std::make_unique<usb::UsbDevice>(usb::make_libusb_port(), described(),
                                                      wish.serial, 1e-3, usb::Pacing::reports);
        } catch (const InputError &) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }
    ASSERT_TRUE(device);
    for (int tick = 0; tick < 500; ++tick) {
        static_cast<void>(device->read());
        device->write(device::DeviceCommand::braking());
        static_cast<void>(std::make_unique<std::string>(100, ' '));
    }
    EXPECT_EQ(testing::watched().allocating_threads, 1);
    EXPECT_EQ(testing::watched().shared_allocations, 0);
}

} // namespace
} // namespace springdrive::usb_test
