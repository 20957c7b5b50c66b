"""What a file may set: every field of the compiled model that is interpreted or without effect.

A field is listed because another file reads and judges it, or because it cannot change a flight.
The rest must be as MuJoCo leaves it (`foreign`), and `CAUSES` says why, where there is more to say.
"""

import re


def _names(*lists: str) -> frozenset[str]:
    return frozenset(" ".join(lists).split())


READ = _names(  # by `wheels`, `rotors`, `joints`, `options`, `timestep`, `numbers`, `shapes`
    "opt.timestep opt.integrator opt.gravity opt.density opt.viscosity opt.wind opt.tolerance",
    "opt.iterations opt.disableflags opt.enableflags stat.meaninertia",
    "body_mass body_inertia body_ipos body_iquat body_pos body_quat body_jntnum",
    "jnt_type jnt_pos jnt_axis jnt_stiffness jnt_range jnt_limited jnt_actfrclimited",
    "jnt_actfrcrange qpos0 qpos_spring dof_damping dof_frictionloss",
    "actuator_trntype actuator_trnid actuator_dyntype actuator_gaintype actuator_biastype",
    "actuator_ctrllimited actuator_ctrlrange actuator_forcelimited actuator_forcerange",
    "actuator_actlimited actuator_actrange actuator_group",
    "geom_type geom_size geom_pos geom_quat geom_group geom_rgba geom_bodyid",
)
STOPS = _names("jnt_margin jnt_solref jnt_solimp")  # of passive joints: inside the spacecraft
DERIVED = _names(  # by MuJoCo's compiler, from what is read
    "nq nv nu nactuator nout na nbody nbvh nbvhstatic nbvhdynamic noct njnt ngeom ntree nM nB nC",
    "nD nemax nnames nnames_map npaths narena nbuffer nJmom nJten nhistory signature names_map",
    "body_parentid body_rootid body_weldid body_jntadr body_dofnum body_dofadr body_geomnum",
    "body_geomadr body_treeid body_simple body_sameframe body_subtreemass body_invweight0",
    "body_bvhadr body_bvhnum jnt_qposadr jnt_dofadr jnt_bodyid jnt_actuatorid dof_bodyid",
    "dof_jntid dof_parentid dof_treeid dof_Madr dof_simplenum dof_invweight0 dof_M0 dof_length",
    "tree_bodyadr tree_bodynum tree_dofadr tree_dofnum actuator_ctrladr actuator_ctrlnum",
    "actuator_outadr actuator_outnum actuator_actadr actuator_actnum actuator_acc0",
    "actuator_length0 actuator_lengthrange geom_aabb geom_rbound geom_sameframe geom_dataid",
    "mapM2M mapM2D mapD2M",
)
NO_CONTACT = _names(  # contacts are off, or no geom could touch another (`options`)
    "opt.impratio opt.cone opt.ccd_tolerance opt.ccd_iterations opt.sdf_initpoints",
    "opt.sdf_iterations opt.noslip_tolerance opt.o_margin opt.o_solref opt.o_solimp",
    "opt.o_friction npair nexclude nconmax npolygonmax body_contype body_conaffinity",
    "body_margin geom_contype geom_conaffinity geom_condim geom_priority geom_solmix geom_solref",
    "geom_solimp geom_friction geom_margin geom_gap",
)
NO_EFFECT = _names(
    "opt.solver opt.jacobian opt.ls_tolerance opt.ls_iterations",  # the plant solves with PGS
    "opt.magnetic opt.sleep_tolerance tree_sleep_policy njmax nuserdata",  # nothing sleeps
    "stat.meanmass stat.meansize stat.extent stat.center nmocap body_mocapid body_user",
    "jnt_group jnt_user geom_matid geom_user geom_castshadow actuator_user",
    "neq eq_type eq_obj1id eq_obj2id eq_objtype eq_solref eq_solimp eq_data",  # all inactive
    "ntendon nwrap tendon_type tendon_adr tendon_num tendon_matid tendon_group tendon_treenum",
    "tendon_treeid tendon_width tendon_range tendon_margin tendon_length0 tendon_lengthspring",
    "tendon_invweight0 tendon_solref_lim tendon_solimp_lim tendon_solref_fri tendon_solimp_fri",
    "tendon_actfrcrange tendon_user tendon_rgba",
)
ALLOWED = READ | STOPS | DERIVED | NO_CONTACT | NO_EFFECT

GROUPS = re.compile(  # tables that only name, draw, measure or remember
    r"n?(site|cam|light|mesh|skin|hfield|tex|mat|sensor|numeric|text|tuple|key|user_).*"
    r"|(pair|exclude|wrap|name|bvh|oct|B|M|D|ten_J)_.*|paths|visual.*"
)
FIRST_ONLY = ("actuator_gear", "actuator_gainprm")  # a joint's motor uses one number of each
HELD_ANYWAY = ("actuator_armature", "actuator_damping", "actuator_dampingpoly")
"""What an actuator does to its joint even when nobody commands it."""

DEFAULTS = """<mujoco><worldbody><body name="bus"><freejoint/><geom size="1"/>
<site name="s"/><site name="r"/><body><joint name="hinge"/><geom size="1"/></body>
<body><joint name="slide" type="slide"/><geom size="1"/></body></body></worldbody>
<tendon><fixed name="f"><joint joint="hinge" coef="1"/></fixed>
<spatial name="t"><site site="s"/><site site="r"/></spatial></tendon>
<equality><weld body1="bus" active="false"/></equality>
<actuator><motor joint="hinge"/><general joint="slide" dyntype="integrator"/></actuator></mujoco>"""
"""A file that sets nothing: what each kind of element has when nobody mentions it."""

Cause = tuple[str, str]
CAUSES: tuple[Cause, ...] = (
    (
        "dof_armature",
        "{who} {has} armature {value}, which weakens the reaction on the bus; put the inertia "
        "into the rotor's <inertial>, armature='0'",
    ),
    (
        "actuator_armature",
        "{who} {has} armature {value}, which weakens the reaction on the bus; put the "
        "inertia into the rotor's <inertial>, armature='0'",
    ),
    (
        "actuator_damping(poly)?",
        "{who} {has} damping {value}; friction is read from the joint, put it there",
    ),
    (
        "dof_dampingpoly|jnt_stiffnesspoly",
        "{who} {has} a damping or stiffness that is a polynomial (.. {value}); springs and "
        "dampers are linear here, give one number",
    ),
    (
        "eq_active0",
        "{who} would hold the spacecraft or tie its parts together, which nothing does in free "
        "flight; remove it from <equality>",
    ),
    (
        "tendon_.*",
        "{who} {has} {attribute} {value}; tendons that pull or resist are not flown, remove it",
    ),
    (
        "n?flex.*|n?efm.*|nJfe",
        "the file has flexible bodies (<flex>, <flexcomp>); put a panel that bends on a hinge "
        "joint with stiffness instead",
    ),
    ("n?plugin.*|.*_plugin", "the file uses plugins, whose forces nobody here knows; remove them"),
    (
        "body_gravcomp|ngravcomp|flg_gravcomp|jnt_actgravcomp",
        "gravcomp: there is no gravity to compensate; remove it",
    ),
    (
        "jnt_springyield|jnt_plasticadr|nplastic",
        "{who} {has} a springyield; springs are elastic here, remove it",
    ),
    (
        "actuator_delay|actuator_history.*",
        "{who} {has} a delay; a wheel's torque follows its command at once, remove delay "
        "and nsample",
    ),
    (
        "(geom|flg)_(surfacevel|adhesion)|geom_fluid",
        "{who} {has} a surfacevel, adhesion or fluidshape; nothing touches here and there is no "
        "fluid, remove it",
    ),
    (
        "opt.disableactuator",
        "<option actuatorgroupdisable>: motors in these groups would give no torque; remove it",
    ),
    (
        "opt.noslip_iterations",
        "<option noslip_iterations='{value}'>: it reworks friction after it was solved; remove it",
    ),
    (
        "dof_solref|dof_solimp",
        "{who} {has} a solreffriction or solimpfriction; friction is as stiff as MuJoCo's "
        "default makes it, remove it",
    ),
)
