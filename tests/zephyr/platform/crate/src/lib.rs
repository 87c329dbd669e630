#![no_std]
use lf_zephyr as _;
