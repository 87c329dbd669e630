// SPDX-License-Identifier: Apache-2.0
//! One federate of a federation.
