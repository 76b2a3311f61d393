#pragma once
#define SYS_futex 202
