"""Python names that a component's ports cannot have: attributes of the runtime's classes."""

from __future__ import annotations

from rtgen.compiler.kit.words import words

COMPONENT_NAMES = words("""
    add_checkpoint add_configuration add_consumer add_in_port add_out_port add_provider
    attach_context config configuration_sets consumers detach_context exit fail finalize folder
    get_context get_context_handle get_owned_contexts get_participating_contexts in_ports initialize
    instance_name is_active is_alive logger lost network now observables on_aborting on_activated
    on_deactivated on_error on_execute on_finalize on_initialize on_rate_changed on_reset
    on_shutdown on_startup on_state_update out_ports profile providers reason report stamp
    """)
"""The public attributes of `rtgen.runtime.Component`, and `config` of the generated bases."""

CANOPEN_NAMES = words("""
    bus_lock description get_object merged_stop networks node objects read_object read_octets
    refusal reports self_start set_object station write_object write_octets
    """)
"""Further attributes of the bases of CANopen proxies, devices and managers."""

CONFIGURATION_NAMES = frozenset(
    {"bool", "bytes", "field", "float", "int", "list", "str"}
)
"""Names used in the declarations of configuration classes, which fields cannot have."""
