#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Starts a federation as the scripts do that lfc generates: the RTI, by its name, as a job in the background that is
# brought back when all federates run; its command line ends with a backslash and a blank. It is called with the names
# of the federates, which are programs in the working directory, and takes the rest from the environment:
#   RTI_PORT    where the RTI listens
#   SLEEP_TIME  for how long the federates are kept back, in seconds; no need to, for they try again
#   MULTIPLE    options for the start time, or nothing

set -m

all_well=false
federates=()

# However this ends, nothing is left behind.
end() {
    if [ "$all_well" != true ]; then
        kill "${federates[@]}" "$RTI"
    fi
}
trap end EXIT

FEDERATION_ID="launched-$$-$RANDOM"

RTI -i ${FEDERATION_ID} \
                        -p ${RTI_PORT} \
                        ${MULTIPLE} \
                        -n $# \
                        -nt 0 \
                        -c init \
exchanges-per-interval 10 \ &
RTI=$!
sleep "${SLEEP_TIME:-1}"
if ! kill -0 $RTI; then
    echo "the RTI has ended already"
    exit 1
fi

for federate in "$@"; do
    "./$federate" -i "$FEDERATION_ID" -r "127.0.0.1:$RTI_PORT" &
    federates+=($!)
done

fg %1
for federate in "${federates[@]}"; do
    wait "$federate" || exit $?
done
all_well=true
echo "the federation has ended well"
