"""What every trigger program has: its variables, and the function blocks of homing and lines.

Templates for `str.format`; Structured Text has no braces. `{x}` and `{y}` are the names of axes.
"""

INTERFACE = """\
INTERFACE
    USEPACKAGE {package};
{uses}
    VAR_GLOBAL CONSTANT
        LAST_OPERATION : DINT := DINT#{last};
        IN_POSITION : LREAL := LREAL#{in_position};
        STANDSTILL : LREAL := LREAL#0.0001;
        PATH_ACCELERATION : LREAL := LREAL#{acceleration};
        HOMING_VELOCITY : LREAL := LREAL#{homing};
        BACK_OFF : LREAL := LREAL#{back_off};
{pierces}
    END_VAR

    VAR_GLOBAL
        limitXLow AT {limits[0]} : BOOL;
        limitXHigh AT {limits[1]} : BOOL;
        limitYLow AT {limits[2]} : BOOL;
        limitYHigh AT {limits[3]} : BOOL;
        startButton AT {start} : BOOL;
{outputs}
        workState : INT := INT#0;
        workDone : BOOL := FALSE;
        workFault : BOOL := FALSE;
        commandFault : BOOL := FALSE;
        axesAtRest : BOOL := FALSE;
        restX : LREAL := LREAL#0.0;
        restY : LREAL := LREAL#0.0;
{globals}
    END_VAR

    FUNCTION_BLOCK FB_Velocity;
{exports}
    FUNCTION_BLOCK FB_Home;
    PROGRAM CutPart;
END_INTERFACE
"""

VELOCITY = """\
    (* Velocity and acceleration of each axis, so that both arrive together. *)
    FUNCTION_BLOCK FB_Velocity
        VAR_INPUT
            wayX : LREAL;
            wayY : LREAL;
            speed : LREAL;
        END_VAR
        VAR_OUTPUT
            velocityX : LREAL;
            velocityY : LREAL;
            accelerationX : LREAL;
            accelerationY : LREAL;
            movesX : BOOL;
            movesY : BOOL;
        END_VAR
        VAR
            length : LREAL;
        END_VAR

        length := SQRT(wayX * wayX + wayY * wayY);
        movesX := ABS(wayX) > LREAL#0.0;
        movesY := ABS(wayY) > LREAL#0.0;
        IF movesX THEN
            velocityX := speed * ABS(wayX) / length;
            accelerationX := PATH_ACCELERATION * ABS(wayX) / length;
        END_IF;
        IF movesY THEN
            velocityY := speed * ABS(wayY) / length;
            accelerationY := PATH_ACCELERATION * ABS(wayY) / length;
        END_IF;
    END_FUNCTION_BLOCK
"""

LINE = """\
    (* A line from one place to another; an axis that stays where it is is not commanded. *)
    FUNCTION_BLOCK FB_Line
        VAR_INPUT
            startX : LREAL;
            startY : LREAL;
            endX : LREAL;
            endY : LREAL;
            speed : LREAL;
        END_VAR
        VAR
            scaled : FB_Velocity;
            answer : DINT;
        END_VAR

        scaled(wayX := endX - startX, wayY := endY - startY, speed := speed);
        IF scaled.movesX THEN
            answer := _pos(
{pos_x});
            IF answer <> DINT#0 THEN
                commandFault := TRUE;
            END_IF;
        END_IF;
        IF scaled.movesY THEN
            answer := _pos(
{pos_y});
            IF answer <> DINT#0 THEN
                commandFault := TRUE;
            END_IF;
        END_IF;
    END_FUNCTION_BLOCK
"""

_POS = """\
                axis := {axis}, direction := POSITIVE, positioningMode := ABSOLUTE,
                position := {position}, velocityType := DIRECT, velocity := {velocity},
                positiveAccelType := DIRECT, positiveAccel := {acceleration},
                negativeAccelType := DIRECT, negativeAccel := {acceleration},
                velocityProfile := TRAPEZOIDAL, mergeMode := IMMEDIATELY,
                nextCommand := IMMEDIATELY"""


def pos(axis: str, position: str, velocity: str, acceleration: str) -> str:
    """The parameters of a `_pos` command."""
    return _POS.format(axis=axis, position=position, velocity=velocity, acceleration=acceleration)


PATH = """\
    (* A line or an arc that the path object runs; it looks after both axes. *)
    FUNCTION_BLOCK FB_PathLine
        VAR_INPUT
            endX : LREAL;
            endY : LREAL;
            speed : LREAL;
        END_VAR
        VAR
            answer : DINT;
        END_VAR

        answer := _movePathLinear(
            pathObject := {path}, pathPlane := X_Y, pathMode := ABSOLUTE,
            x := endX, y := endY, velocityType := DIRECT, velocity := speed,
            positiveAccelType := DIRECT, positiveAccel := PATH_ACCELERATION,
            negativeAccelType := DIRECT, negativeAccel := PATH_ACCELERATION,
            velocityProfile := TRAPEZOIDAL, mergeMode := SEQUENTIAL,
            nextCommand := IMMEDIATELY);
        IF answer <> DINT#0 THEN
            commandFault := TRUE;
        END_IF;
    END_FUNCTION_BLOCK

    FUNCTION_BLOCK FB_PathCircle
        VAR_INPUT
            middleX : LREAL;
            middleY : LREAL;
            endX : LREAL;
            endY : LREAL;
            speed : LREAL;
        END_VAR
        VAR
            answer : DINT;
        END_VAR

        answer := _movePathCircular(
            pathObject := {path}, pathPlane := X_Y,
            circularType := OVER_POSITION_TO_ENDPOSITION, pathMode := ABSOLUTE,
            x := endX, y := endY, ijkMode := ABSOLUTE, i := middleX, j := middleY,
            velocityType := DIRECT, velocity := speed,
            positiveAccelType := DIRECT, positiveAccel := PATH_ACCELERATION,
            negativeAccelType := DIRECT, negativeAccel := PATH_ACCELERATION,
            velocityProfile := TRAPEZOIDAL, mergeMode := SEQUENTIAL,
            nextCommand := IMMEDIATELY);
        IF answer <> DINT#0 THEN
            commandFault := TRUE;
        END_IF;
    END_FUNCTION_BLOCK
"""

HOME = """\
    (* Homing of one axis: against the low limit switch, stop, zero, back off, zero. *)
    FUNCTION_BLOCK FB_Home
        VAR_INPUT
            axis : posAxis;
            limitClosed : BOOL;
        END_VAR
        VAR_OUTPUT
            homed : BOOL := FALSE;
        END_VAR
        VAR
            phase : INT := INT#0;
            lastPosition : LREAL;
            answer : DINT := DINT#0;
        END_VAR

        CASE phase OF
            0:
                answer := _enableAxis(axis := axis, nextCommand := IMMEDIATELY);
                phase := INT#1;
            1:
                IF axis.control = ACTIVE THEN
                    answer := _move(
                        axis := axis, direction := NEGATIVE,
                        velocityType := DIRECT, velocity := HOMING_VELOCITY,
                        mergeMode := IMMEDIATELY, nextCommand := IMMEDIATELY);
                    phase := INT#2;
                END_IF;
            2:
                IF limitClosed THEN
                    answer := _stop(
                        axis := axis, stopMode := STOP_AND_ABORT, nextCommand := IMMEDIATELY);
                    phase := INT#3;
                END_IF;
            3:
                IF ABS(axis.basicMotion.position - lastPosition) <= STANDSTILL THEN
                    answer := _homing(
                        axis := axis, homingMode := DIRECT_HOMING, homePositionType := DIRECT,
                        homePosition := LREAL#0.0, nextCommand := IMMEDIATELY);
                    phase := INT#4;
                END_IF;
            4:
                answer := _pos(
{back_off});
                phase := INT#5;
            5:
                IF (ABS(axis.basicMotion.position - BACK_OFF) <= IN_POSITION)
                    AND (ABS(axis.basicMotion.position - lastPosition) <= STANDSTILL) THEN
                    answer := _homing(
                        axis := axis, homingMode := DIRECT_HOMING, homePositionType := DIRECT,
                        homePosition := LREAL#0.0, nextCommand := IMMEDIATELY);
                    phase := INT#6;
                END_IF;
            6:
                homed := TRUE;
        END_CASE;
        lastPosition := axis.basicMotion.position;
        IF answer <> DINT#0 THEN
            commandFault := TRUE;
        END_IF;
    END_FUNCTION_BLOCK
"""

PROGRAM = """\
    PROGRAM CutPart
        VAR
            homeX : FB_Home;
            homeY : FB_Home;
            answer : DINT := DINT#0;
{locals}
        END_VAR

        (* At rest: no way since the last cycle. An axis that moves would lead the next line. *)
        axesAtRest := (ABS({x}.basicMotion.position - restX) <= STANDSTILL)
            AND (ABS({y}.basicMotion.position - restY) <= STANDSTILL);
        restX := {x}.basicMotion.position;
        restY := {y}.basicMotion.position;

        (* A limit switch that closes during work, or a command that was refused, stops all. *)
        IF commandFault OR ((workState = INT#2)
            AND (limitXLow OR limitXHigh OR limitYLow OR limitYHigh)) THEN
            IF NOT workFault THEN
{stops}
            END_IF;
            workFault := TRUE;
            workState := INT#4;
        END_IF;

        CASE workState OF
            0: (* wait for the operator *)
{all_off}
                IF startButton THEN
                    workState := INT#1;
                END_IF;
            1: (* homing *)
                homeX(axis := {x}, limitClosed := limitXLow);
                homeY(axis := {y}, limitClosed := limitYLow);
                IF homeX.homed AND homeY.homed THEN
{begin}
                    workState := INT#2;
                END_IF;
            2: (* work *)
{work}
            3: (* done *)
{all_off}
                workDone := TRUE;
            4: (* fault: until the power is switched off *)
{all_off}
        END_CASE;
    END_PROGRAM
"""

STOP = """\
                answer := _stop(
                    axis := {axis}, stopMode := STOP_AND_ABORT, nextCommand := IMMEDIATELY);"""
STOP_PATH = """\
                answer := _stopPath(
                    pathObject := {path}, stopMode := STOP_AND_ABORT,
                    nextCommand := IMMEDIATELY);"""
