"""The fixed parts of the settlement deck; names in braces are filled in."""

__all__ = ["HEADER", "MATERIAL", "MESH", "RESULTS", "SOLUTION"]

HEADER = """\
! facade_settlement.inp - settlement of a masonry facade; SI units (N, m, kg, s)
! x along the wall, y into it from its front at y = 0, z up; tension positive.
!
! NOTHING IN THIS DECK HAS EVER BEEN RUN IN ANSYS. Part by part:
!
! part                   written after                                      run in ANSYS
! ---------------------  -------------------------------------------------  ------------
! neutral file           three files that ANSYS itself wrote; the sign of   never
!                        an area that two volumes share is inferred
! command deck (K/A/VA)  public manual pages of K, L, A, AL, VA             never
! elastic, SOLID185      public manual pages of MP, SOLID185                never
! EDP, SOLID185          public manual pages of TB,EDP and a public note    never
!                        on its constants
! concrete, SOLID185     public manual page of TB,CONCR; the order of the   never
!                        constants of HSD6 is FROM MEMORY: look it up
! SOLID65                public manual pages of SOLID65 and TB,CONCR and    never
!                        the public verification case VM146; that TB,DP
!                        still goes with it in current releases is not sure
! mesh                   public manual pages of ESIZE, EXTOPT, VSWEEP       never
! tables of the base     public manual pages of *DIM and D                  never
! solution, results      public manual pages of the commands; ANSYS's own   never
!                        examples use them alike
!
! What has been checked, by other programs: that the neutral file is sound and has the
! volume below; that this deck is closed, uses only what it defines, and that its tables
! hold the movement of the base.
FINISH
/CLEAR,NOSTART
/FILNAME,facade,1
/TITLE,facade settlement
/UNITS,SI
! ------------------------------------------------------------------------------- choices
! MODEL 0  SOLID185, linear elastic: to compare with other programs first
!       1  SOLID185, extended Drucker-Prager; it has no limit in tension but its cone
!       2  SOLID185, Menetrey-Willam concrete with linear softening
!       3  SOLID65 (archived), Willam-Warnke concrete with Drucker-Prager: the paper's
MODEL=1
EMOD={young} ! Young's modulus, Pa
PNU={poisson} ! Poisson's ratio
RHO={density} ! density, kg/m3
GRAV={gravity} ! gravity, m/s2, downwards
COHE={cohesion} ! cohesion, Pa
PHI={friction} ! angle of friction, degrees
PSI={dilatancy} ! angle of dilatancy, degrees
FTEN={tension} ! uniaxial tensile strength, Pa
FCOM={compression} ! uniaxial compressive strength, Pa
H={size} ! element size, m: two through the thinnest wall
VOLEXP={volume} ! volume of the wall, m3
! ------------------------------------------------------------------------------ geometry
/INPUT,{file},{suffix}
! If ANSYS refuses that file, take the same solid as commands instead:
! /INPUT,{file}_apdl,inp
/PREP7
ALLSEL,ALL
*GET,NVOLGOT,VOLU,,COUNT
VSUM,DEFAULT
*GET,VOLGOT,VOLU,,VOLU
*IF,NVOLGOT,NE,{volumes},THEN
 *MSG,ERROR,NVOLGOT
 %I VOLUMES WERE READ, {volumes} EXPECTED
*ENDIF
*IF,ABS(VOLGOT/VOLEXP-1),GT,1E-6,THEN
 *MSG,ERROR,VOLGOT,VOLEXP
 THE VOLUME READ IS %G, EXPECTED %G
*ENDIF
"""

MATERIAL = """\
! ------------------------------------------------------------------------------ material
MP,EX,1,EMOD
MP,PRXY,1,PNU
MP,DENS,1,RHO
*AFUN,DEG
REALN=0
*IF,MODEL,EQ,3,THEN
 ET,1,SOLID65
 KEYOPT,1,1,0                   ! extra displacement shapes
 KEYOPT,1,7,1                   ! tensile stress relaxes after cracking
 R,1                            ! no reinforcement
 REALN=1
 TB,CONCR,1,1,9                 ! Willam-Warnke
 TBDATA,1,0.3,0.9,FTEN,-1       ! shear across open and closed cracks, ft, fc = -1: no crushing
 TBDATA,9,0.6                   ! part of ft that is left when a crack opens
 TB,DP,1                        ! Drucker-Prager
 TBDATA,1,COHE,PHI,PSI
*ELSE
 ET,1,SOLID185
 KEYOPT,1,2,3                   ! simplified enhanced strain
*ENDIF
*IF,MODEL,EQ,1,THEN
 TB,EDP,1,1,2,LYFUN             ! q + alpha*sm - sy = 0, on the compressive edges of Mohr-Coulomb
 TBDATA,1,6*SIN(PHI)/(3-SIN(PHI)),6*COHE*COS(PHI)/(3-SIN(PHI))
 TB,EDP,1,1,1,LFPOT
 TBDATA,1,6*SIN(PSI)/(3-SIN(PSI))
*ENDIF
*IF,MODEL,EQ,2,THEN
 TB,CONCR,1,1,3,MW              ! Menetrey-Willam
 TBDATA,1,FCOM,FTEN,1.2*FCOM    ! uniaxial compression and tension, biaxial compression
 TB,CONCR,1,1,1,DILA
 TBDATA,1,PSI
 TB,CONCR,1,1,6,HSD6            ! linear softening; order of the constants from memory
 TBDATA,1,0.002,0.01,0.33,0.2,0.001,0.1
*ENDIF
*AFUN,RAD
"""

MESH = """\
! ---------------------------------------------------------------------------------- mesh
ALLSEL,ALL
VATT,1,REALN,1
ESIZE,H
MSHAPE,0,2D
MSHAPE,0,3D
MSHKEY,2                        ! mapped where it can be, else free
EXTOPT,VSWE,AUTO,ON
EXTOPT,VSWE,TETS,OFF
VSWEEP,ALL                      ! each volume is a prism through the wall
NUMCMP,NODE
*GET,ZMIN,NODE,0,MNLOC,Z
NSEL,S,LOC,Z,ZMIN-1E-6,ZMIN+1E-6
CM,BASE,NODE
ALLSEL,ALL
FINISH
"""

SOLUTION = """\
! ------------------------------------------------------------------------------ solution
/SOLU
ANTYPE,STATIC
NLGEOM,OFF
NROPT,UNSYM                     ! the flow is not associated
AUTOTS,ON
OUTRES,ALL,LAST
ACEL,0,0,GRAV                   ! the frame is accelerated upwards: weight acts along -z
CMSEL,S,BASE
D,ALL,UX,%UXBASE%
D,ALL,UY,%UYBASE%
D,ALL,UZ,%UZBASE%
ALLSEL,ALL
KBC,0                           ! ramped
TIME,1                          ! step 1: self-weight, the base at rest
NSUBST,10,100,5
SOLVE
TIME,2                          ! step 2: the base moves
NSUBST,50,2000,20
SOLVE
FINISH
"""

RESULTS = """\
! ------------------------------------------------------------------------------- results
/POST1
*DO,NSTEP,1,2
 SET,NSTEP,LAST
 ALLSEL,ALL
 NSORT,U,SUM
 *GET,UMAX,SORT,0,MAX
 NSORT,S,1
 *GET,S1MAX,SORT,0,MAX
 CMSEL,S,BASE
 *GET,NBASE,NODE,0,COUNT
 FZSUM=0
 NNOW=0
 *DO,I,1,NBASE
  NNOW=NDNEXT(NNOW)
  *GET,FZNOW,NODE,NNOW,RF,FZ
  FZSUM=FZSUM+FZNOW
 *ENDDO
 ALLSEL,ALL
 WEIGHT=RHO*GRAV*VOLGOT
 *MSG,INFO,NSTEP,UMAX,S1MAX
 STEP %I: LARGEST DISPLACEMENT %G M, LARGEST S1 %G PA
 *MSG,INFO,FZSUM,WEIGHT
 SUM OF THE REACTIONS %G N, WEIGHT %G N
*ENDDO
*IF,MODEL,EQ,3,THEN
 PLCRACK,0,1
*ENDIF
PLNSOL,U,SUM
PLNSOL,S,1
FINISH
"""
