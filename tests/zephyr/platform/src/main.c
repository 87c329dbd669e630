#include <zephyr/ztest.h>
ZTEST_SUITE(platform, NULL, NULL, NULL, NULL, NULL);
