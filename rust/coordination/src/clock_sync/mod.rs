// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization between a federate and the RTI.
